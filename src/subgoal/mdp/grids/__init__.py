"""Grid worlds: cells and walls, maps and floor plans, positions to cells, features."""
