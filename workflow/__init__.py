"""Discrete-element simulation of cohesive powders and granular heaps on LAMMPS.

One way through, each step with one door::

    Scene -> Deck -> Run -> Archive -> Measures -> Report

The command is ``wf``; every command is a thin layer over plain functions of this package.
"""

__version__ = "0.3.0"
