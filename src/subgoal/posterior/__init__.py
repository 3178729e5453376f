"""sample(), Posterior, status and diagnostics."""
