"""The benchmark: `python -m isomend.bench` fills holes whose truth is known with all tools that are installed, and scores them."""
