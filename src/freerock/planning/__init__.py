"""Before a test: how well one run will tell the parameters of a law."""
