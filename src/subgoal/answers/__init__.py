"""What a posterior says about these demonstrations: subgoals, segments, partitions, residuals."""
