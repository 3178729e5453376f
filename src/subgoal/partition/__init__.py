"""Chinese restaurant processes and exact samplers: arrays in, draws out; knows nothing of control."""
