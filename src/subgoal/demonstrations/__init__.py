"""Files in, frozen Demonstrations out: readers, resampling, velocities, thinning, units."""
