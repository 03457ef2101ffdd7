"""Lines of LINE data that tests of modes share: level sections, bundles, phases."""

from gallop_fmu import LineScene

GRAVITY = 9.81


def section(
    tension,
    spans,
    weight,
    axial_stiffness,
    *,
    string=(2.1, 490.0),
    elements=30,
    diameter=0.02763,
    torsion=(1e4, 1e-4),
    **tables,
):
    """A level section between rigid ends.

    Parameters
    ----------
    tension, axial_stiffness
        Horizontal tension and EA of a subconductor [N].
    spans
        Lengths [m].
    weight
        Per length [N/m] of the *unstretched* conductor, as in OpenSees; the scene has that of the
        hanging one.
    string
        Length [m] and weight [N] of the suspension strings; None: posts.
    torsion
        GJ [N m2/rad] and I [kg m].
    tables
        Further tables of the scene.
    """
    held = {"kind": "post"}
    if string is not None:
        held = {"kind": "string", "length": string[0], "weight": string[1]}
    return LineScene.from_dict(
        {
            "title": "test",
            "section": {
                "horizontal_tension": tension,
                "gravity": GRAVITY,
                "spans": [{"length": length} for length in spans],
                "suspensions": [held] * (len(spans) - 1),
            },
            "conductor": {
                "diameter": diameter,
                "mass_per_length": weight / GRAVITY / (1.0 + tension / axial_stiffness),
                "axial_stiffness": axial_stiffness,
                "torsional_stiffness": torsion[0],
                "torsional_inertia": torsion[1],
            },
            "numerics": {"elements": elements},
            **tables,
        }
    )


def zebra(spans=1, **changes):
    """Zebra on level spans of 300 m."""
    return section(19785.0, [300.0] * spans, 15.90, 44.389e6, **changes)


def in_plane(modes):
    """Frequencies [Hz] of modes in the vertical plane, ascending."""
    names = ("vertical", "longitudinal", "tension-neutral")
    return [mode.frequency_hz for mode in modes if mode.family in names]


def of_family(modes, *families):
    """Frequencies [Hz] of modes of these families, ascending."""
    return [mode.frequency_hz for mode in modes if mode.family in families]
