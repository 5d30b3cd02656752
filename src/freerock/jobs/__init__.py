"""What the jobs of the workflow do, and what runs and jobs share."""
