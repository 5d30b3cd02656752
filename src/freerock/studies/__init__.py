"""Studies of the methods: what they cost, how far they are from the truth, and where they fail."""
