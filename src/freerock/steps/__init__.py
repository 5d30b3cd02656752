"""What the jobs do for one record: read products or record files, call the steps, write a product."""
