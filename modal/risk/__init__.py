"""Risk of many spans: probabilities from distributions of wind and ice."""
