"""What roadside engineers read off an impact: filtered forces, peaks, durations, design forces, occupant risk."""
