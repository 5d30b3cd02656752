"""Before a test: how well a run determines the parameters, which rival it excludes, how many it takes."""

__all__ = ["cramer_rao", "plan", "plan_campaign", "plan_total", "rivals"]
