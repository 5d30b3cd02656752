"""freerock: free-rocking tests, from laser volts to identified models."""
