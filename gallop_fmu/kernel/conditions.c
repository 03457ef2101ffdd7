/* The inputs at one instant, from the laws of the scene or from a host. */
#include "conditions.h"

#include "base_math.h"
#include "law.h"

/* The first mass moments turn with the ice; the scene gives them at first_moment_angle. */
void conditions_rotate_moments(const gallop_scene *scene, double attack, double *c2, double *c3)
{
    double sine, cosine;
    sine_cosine(attack - scene->first_moment_angle, &sine, &cosine);
    *c2 = scene->first_moment_x2 * cosine - scene->first_moment_x3 * sine;
    *c3 = scene->first_moment_x2 * sine + scene->first_moment_x3 * cosine;
}

void conditions_at(const gallop_model *model, double t, const gallop_inputs *inputs,
                   conditions *now)
{
    now->load_factor = 1.0;
    if (inputs) {
        double dt = t - inputs->time;
        now->wind = inputs->wind_speed + inputs->wind_speed_rate * dt;
        now->attack = inputs->attack_angle + inputs->attack_angle_rate * dt;
        conditions_rotate_moments(&model->scene, now->attack, &now->c2, &now->c3);
        for (int end = 0; end < 2; end++)
            for (int i = 0; i < 3; i++) {
                now->position[end][i] = inputs->support[end][i] + inputs->support_rate[end][i] * dt;
                now->velocity[end][i] = inputs->support_rate[end][i];
                now->acceleration[end][i] = 0.0;
            }
        return;
    }
    now->wind = law_value(&model->scene.wind, t);
    now->attack = model->scene.attack_angle;
    now->c2 = model->c2;
    now->c3 = model->c3;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++) {
            const gallop_law *motion = &model->scene.support[end].motion[i];
            now->position[end][i] = law_value(motion, t);
            now->velocity[end][i] = law_rate(motion, t);
            now->acceleration[end][i] = law_second(motion, t);
        }
}

bool conditions_are_finite(const conditions *now)
{
    bool ok = isfinite(now->wind) && isfinite(now->attack) && isfinite(now->load_factor) &&
              isfinite(now->c2) && isfinite(now->c3);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            ok = ok && isfinite(now->position[end][i]) && isfinite(now->velocity[end][i]) &&
                 isfinite(now->acceleration[end][i]);
    return ok;
}
