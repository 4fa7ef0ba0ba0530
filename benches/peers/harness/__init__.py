"""The parts of `run.py`, each of one concept."""
