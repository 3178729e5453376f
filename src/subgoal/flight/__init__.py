"""From subgoals to flight: waypoints, a smooth path through them, a simulated quadrotor, and how well it followed."""
