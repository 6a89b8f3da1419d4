"""The benchmark: `python -m isomend.bench` fills holes whose true surface is known, with all installed tools, and scores the patches."""
