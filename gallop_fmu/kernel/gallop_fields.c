/* Version, build, and the fields of the structures of gallop.h, for a binding to compare its own.
 */
#include "base_lanes.h"
#include "base_memory.h"
#include "gallop.h"

typedef struct {
    const char *structure, *field;
    size_t offset, size;
} entry;

#define STRUCTURE(type) {#type, NULL, 0, sizeof(type)}
#define FIELD(type, name) {#type, #name, offsetof(type, name), sizeof(((type *)0)->name)}

/* clang-format off */
static const entry entries[] = {
    STRUCTURE(gallop_law),
    FIELD(gallop_law, kind),
    FIELD(gallop_law, count),
    FIELD(gallop_law, first),
    FIELD(gallop_law, repeat),
    FIELD(gallop_law, initial),
    FIELD(gallop_law, peak),
    FIELD(gallop_law, amplitude),
    FIELD(gallop_law, start),
    FIELD(gallop_law, rise),
    FIELD(gallop_law, fall_start),
    FIELD(gallop_law, fall),
    FIELD(gallop_law, frequency),
    FIELD(gallop_law, phase),

    STRUCTURE(gallop_curve),
    FIELD(gallop_curve, pieces),
    FIELD(gallop_curve, outside),
    FIELD(gallop_curve, first),
    FIELD(gallop_curve, reserved),

    STRUCTURE(gallop_damping),
    FIELD(gallop_damping, low_ratio),
    FIELD(gallop_damping, low_frequency),
    FIELD(gallop_damping, high_ratio),
    FIELD(gallop_damping, high_frequency),

    STRUCTURE(gallop_cross_section),
    FIELD(gallop_cross_section, diameter),
    FIELD(gallop_cross_section, mass),
    FIELD(gallop_cross_section, axial_stiffness),
    FIELD(gallop_cross_section, torsional_stiffness),
    FIELD(gallop_cross_section, torsional_inertia),
    FIELD(gallop_cross_section, ice_mass),
    FIELD(gallop_cross_section, ice_torsional_inertia),
    FIELD(gallop_cross_section, first_moment_x2),
    FIELD(gallop_cross_section, first_moment_x3),
    FIELD(gallop_cross_section, first_moment_angle),
    FIELD(gallop_cross_section, attack_angle),
    FIELD(gallop_cross_section, reference_radius),
    FIELD(gallop_cross_section, thermal_expansion),
    FIELD(gallop_cross_section, translation_damping),
    FIELD(gallop_cross_section, twist_damping),
    FIELD(gallop_cross_section, curve),
    FIELD(gallop_cross_section, slack),

    STRUCTURE(gallop_field),
    FIELD(gallop_field, kind),
    FIELD(gallop_field, law),
    FIELD(gallop_field, direction),
    FIELD(gallop_field, profile),
    FIELD(gallop_field, profile_parameter),
    FIELD(gallop_field, reference_height),
    FIELD(gallop_field, ground_points),
    FIELD(gallop_field, first_ground),
    FIELD(gallop_field, stations),
    FIELD(gallop_field, times),
    FIELD(gallop_field, components),
    FIELD(gallop_field, first_gust),
    FIELD(gallop_field, repeat),
    FIELD(gallop_field, reserved),

    STRUCTURE(gallop_junction),
    FIELD(gallop_junction, position),
    FIELD(gallop_junction, fixed),
    FIELD(gallop_junction, motion),
    FIELD(gallop_junction, reserved),

    STRUCTURE(gallop_chain),
    FIELD(gallop_chain, cross_section),
    FIELD(gallop_chain, field),
    FIELD(gallop_chain, junction),
    FIELD(gallop_chain, elements),
    FIELD(gallop_chain, reserved),
    FIELD(gallop_chain, sag),
    FIELD(gallop_chain, horizontal_tension),

    STRUCTURE(gallop_station),
    FIELD(gallop_station, chain),
    FIELD(gallop_station, corner),
    FIELD(gallop_station, junction),
    FIELD(gallop_station, cross_section),
    FIELD(gallop_station, position),

    STRUCTURE(gallop_device),
    FIELD(gallop_device, kind),
    FIELD(gallop_device, junctions),
    FIELD(gallop_device, junction),
    FIELD(gallop_device, parameter),

    STRUCTURE(gallop_load),
    FIELD(gallop_load, chain),
    FIELD(gallop_load, law),
    FIELD(gallop_load, evenly_spaced),
    FIELD(gallop_load, reserved),
    FIELD(gallop_load, position),
    FIELD(gallop_load, force),
    FIELD(gallop_load, torque),

    STRUCTURE(gallop_shedding),
    FIELD(gallop_shedding, chain),
    FIELD(gallop_shedding, corner),
    FIELD(gallop_shedding, cross_section),
    FIELD(gallop_shedding, reserved),
    FIELD(gallop_shedding, time),
    FIELD(gallop_shedding, acceleration),

    STRUCTURE(gallop_settings),
    FIELD(gallop_settings, gravity),
    FIELD(gallop_settings, air_density),
    FIELD(gallop_settings, seed_vertical),
    FIELD(gallop_settings, seed_horizontal),
    FIELD(gallop_settings, seed_twist),
    FIELD(gallop_settings, time_step),
    FIELD(gallop_settings, newton_tolerance),
    FIELD(gallop_settings, tolerance),
    FIELD(gallop_settings, spectral_radius),
    FIELD(gallop_settings, max_newton_iterations),
    FIELD(gallop_settings, max_halvings),
    FIELD(gallop_settings, integrator),
    FIELD(gallop_settings, start_in_mean_wind),
    FIELD(gallop_settings, laws_only),
    FIELD(gallop_settings, strung),
    FIELD(gallop_settings, strung_with_ice),
    FIELD(gallop_settings, portable),
    FIELD(gallop_settings, strung_temperature),
    FIELD(gallop_settings, temperature),

    STRUCTURE(gallop_scene),
    FIELD(gallop_scene, settings),
    FIELD(gallop_scene, cross_section_count),
    FIELD(gallop_scene, curve_count),
    FIELD(gallop_scene, field_count),
    FIELD(gallop_scene, junction_count),
    FIELD(gallop_scene, chain_count),
    FIELD(gallop_scene, station_count),
    FIELD(gallop_scene, device_count),
    FIELD(gallop_scene, load_count),
    FIELD(gallop_scene, law_count),
    FIELD(gallop_scene, shedding_count),
    FIELD(gallop_scene, number_count),
    FIELD(gallop_scene, cross_section),
    FIELD(gallop_scene, curve),
    FIELD(gallop_scene, field),
    FIELD(gallop_scene, junction),
    FIELD(gallop_scene, chain),
    FIELD(gallop_scene, station),
    FIELD(gallop_scene, device),
    FIELD(gallop_scene, load),
    FIELD(gallop_scene, law),
    FIELD(gallop_scene, shedding),
    FIELD(gallop_scene, number),

    STRUCTURE(gallop_report),
    FIELD(gallop_report, outcome),
    FIELD(gallop_report, element),
    FIELD(gallop_report, device),
    FIELD(gallop_report, reserved),
    FIELD(gallop_report, time),
    FIELD(gallop_report, value),
    FIELD(gallop_report, limit),
    FIELD(gallop_report, field),
    FIELD(gallop_report, lowest_tension),
    FIELD(gallop_report, largest_turn),
    FIELD(gallop_report, steps),
    FIELD(gallop_report, substeps),
    FIELD(gallop_report, iterations),
    FIELD(gallop_report, refactorisations),
    FIELD(gallop_report, halvings),
    FIELD(gallop_report, rejections),

    STRUCTURE(gallop_inputs),
    FIELD(gallop_inputs, time),
    FIELD(gallop_inputs, attack_angle),
    FIELD(gallop_inputs, attack_angle_rate),
    FIELD(gallop_inputs, fields),
    FIELD(gallop_inputs, junctions),
    FIELD(gallop_inputs, wind),
    FIELD(gallop_inputs, direction),
    FIELD(gallop_inputs, motion),

    STRUCTURE(gallop_probe),
    FIELD(gallop_probe, object),
    FIELD(gallop_probe, index),
    FIELD(gallop_probe, channel),
    FIELD(gallop_probe, reserved),
    FIELD(gallop_probe, station),

    STRUCTURE(gallop_derived),
    FIELD(gallop_derived, sag),
    FIELD(gallop_derived, horizontal_tension),
    FIELD(gallop_derived, length),
    FIELD(gallop_derived, support_force),
    FIELD(gallop_derived, support_stiffness),
    FIELD(gallop_derived, translation_damping),
    FIELD(gallop_derived, twist_damping),
    FIELD(gallop_derived, imbalance),
    FIELD(gallop_derived, parts),
    FIELD(gallop_derived, threads),

    STRUCTURE(gallop_team),
    FIELD(gallop_team, content),

    STRUCTURE(gallop_derived_chain),
    FIELD(gallop_derived_chain, sag),
    FIELD(gallop_derived_chain, horizontal_tension),
    FIELD(gallop_derived_chain, length),
    FIELD(gallop_derived_chain, end_force),
};
/* clang-format on */

const char *gallop_build(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#elif defined(_MSC_VER)
    return "Microsoft C";
#else
    return "unknown compiler";
#endif
}

int32_t gallop_has_fused_path(void)
{
    return base_has_fused_path();
}

int32_t gallop_api_version(void)
{
    return GALLOP_API_VERSION;
}

int gallop_structure_field(int32_t index, const char **structure, const char **field,
                           size_t *offset, size_t *size)
{
    if (index < 0 || index >= (int32_t)(sizeof entries / sizeof *entries)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(structure, sizeof *structure)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(field, sizeof *field)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(offset, sizeof *offset)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(size, sizeof *size)) return GALLOP_BAD_CALL;
    *structure = entries[index].structure;
    *field = entries[index].field;
    *offset = entries[index].offset;
    *size = entries[index].size;
    return GALLOP_COMPLETED;
}
