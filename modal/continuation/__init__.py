"""Continuation of equilibria and periodic orbits of y' = f(y, p), with their stability and events.

`starts.equilibria`, `starts.orbits` and `starts.switched` follow branches; `diagram.explore`
follows all that can be reached. A system is a `problem.Problem`; results are `branch.Branch`
objects with `path.Point` and `events.Event`, and tables (`Branch.dataset`).

Periodic orbits are found by orthogonal collocation, not by harmonic balance: the mesh adapts to
kinks of coefficient curves and to long periods near homoclinic orbits, the error is estimated, and
the condensed equations give the Floquet multipliers. Harmonic balance needs fewer unknowns for
nearly harmonic motions, but its resolution does not adapt.

Why own code (packages of PyPI in November 2026):

- bifpy 0.3 (AUTO-07p) has all functions needed, but no wheels: its installation compiles Fortran
  with gfortran and GNU Make, which users on Windows rarely have. It calls f for one state at a
  time, in a process of its own; the wind load is cheap only if the kernel evaluates it for all
  collocation points at once.
- pycont-lite 0.6 follows limit cycles on a fixed mesh of second order, without multipliers and
  events.
- bice 0.4.6 is made for partial differential equations: orbits by finite differences, multipliers
  by a product of matrices, no period doublings or tori.
"""
