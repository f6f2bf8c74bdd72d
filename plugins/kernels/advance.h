/* SPDX-License-Identifier: GPL-2.0-or-later
   Velocity Verlet on the kernel's records of the grains, in as few passes over memory as the scheme allows.

   Stateless, and the same bits whichever parts are taken together: a whole kick is two half kicks in one pass. */

#ifndef DISC_KERNELS_ADVANCE_H
#define DISC_KERNELS_ADVANCE_H

#include "sweep.h"

namespace disc
{

struct alignas(16) Inertia {    // both 0 for a grain that does not move
  double mass, inverse_moment;
};

struct Kick {    // half of one
  double dt = 0.0;
  double gravity[2] = {0.0, 0.0};    // acceleration: the weight of a grain is where its next action begins
  double kept[2] = {1.0, 1.0};       // factors on the velocity before it, from drag and convention
  double kept_spin = 1.0;
};

struct Shift {    // of positions: x -> corner + stretch (x - corner) + drift v
  double corner[2] = {0.0, 0.0}, stretch[2] = {1.0, 1.0}, drift[2] = {0.0, 0.0};
};

struct Passed {
  double xx = 0.0, yy = 0.0;        // m v_x^2, m v_y^2 at the full step, between the two half kicks
  double scaled[2] = {0.0, 0.0};    // m v^2 + I w^2 before the scaling of each half kick: FINISH, BEGIN
  double largest = 0.0;             // bound on the displacements beyond the affine motion, squared
  double sum = 0.0;                 // not a number if any displacement is
};

/* One pass over the grains.  FINISH: the half kick that ends a step, with the kinetic sums.  BEGIN: the one that starts
   the next, which also leaves nothing but the weight in the actions.  SHIFT: the positions move; STRETCH: with the
   cell. */
template <bool FINISH, bool BEGIN, bool SCALED, bool SHIFT, bool STRETCH>
DISC_WIDEST Passed advance(const Kick &kick, const Shift &shift, const Inertia *inertia, Action *action, Grain *grain,
                           int count)
{
  const Four dt = {0.0, 0.0, kick.dt, kick.dt}, gravity = {kick.gravity[0], kick.gravity[1], 0.0, 0.0};
  const Four kept = {1.0, 1.0, kick.kept[0], kick.kept[1]};
  const Four corner = {shift.corner[0], shift.corner[1], 0.0, 0.0},
             stretch = {shift.stretch[0], shift.stretch[1], 1.0, 1.0};
  const Four drift = {shift.drift[0], shift.drift[1], 0.0, 0.0};
  Four kinetic{}, largest{}, sum{};
  double scaled[2] = {0.0, 0.0};
  for (int i = 0; i < count; i++) {
    Grain &g = grain[i];
    Four place = four(&g.x);    // x y vx vy
    if (FINISH || BEGIN) {
      const Four act = four(&action[i].fx);    // fx fy moment tangential
      const Four push = dt * g.inverse_mass * DISC_PICK(act, act, 0, 1, 0, 1);
      const double turn = kick.dt * inertia[i].inverse_moment * (act[2] + g.r * act[3]);
      double w = g.w;
      for (int half = 0; half < FINISH + BEGIN; half++) {
        if (SCALED) {
          scaled[FINISH ? half : 1] +=
              inertia[i].mass * (place[2] * place[2] + place[3] * place[3]) + w * w / inertia[i].inverse_moment;
          place *= kept;
          w *= kick.kept_spin;
        }
        place += push;
        w += turn;
        if (FINISH && half == 0) kinetic += inertia[i].mass * place * place;
      }
      g.w = w;
      g.rw = g.r * w;
      if (BEGIN) four(&action[i].fx) = inertia[i].mass * gravity;
    }
    if (SHIFT) {
      const Four move = drift * DISC_PICK(place, place, 2, 3, 2, 3);
      place = (STRETCH ? corner + stretch * (place - corner) : place) + move;
      const Four squares = move * move;
      largest = squares > largest ? squares : largest;
      sum += squares;
    }
    four(&g.x) = place;
  }
  return {kinetic[2], kinetic[3], {scaled[0], scaled[1]}, largest[0] + largest[1], sum[0] + sum[1]};
}

}    // namespace disc

#endif
