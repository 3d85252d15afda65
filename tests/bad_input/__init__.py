"""Input that cannot be used, made by hand, at random and by a fuzzer; faults of disks, memory and processes."""
