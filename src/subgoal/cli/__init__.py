"""Commands without science in them."""
