"""All motions of a span over one number of its scene: equilibria and periodic motions.

`span_model` reduces the span to its lowest modes, `span_problem` is that model as a system for
`modal.continuation`, `branches` follows everything that is connected with the equilibrium.
"""
