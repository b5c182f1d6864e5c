"""Small motions of scenes with sampled controllers."""
