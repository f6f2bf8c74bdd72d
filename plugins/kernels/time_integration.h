/* SPDX-License-Identifier: GPL-2.0-or-later
   Velocity Verlet (kick, drift, kick) on the kernel's copies of the grains, in as few passes over memory as possible.

   Stateless.  The bits do not depend on which parts are taken in one pass: a whole kick is two half kicks.
   Words: docs/glossary.md. */

#ifndef DISC_KERNELS_TIME_INTEGRATION_H
#define DISC_KERNELS_TIME_INTEGRATION_H

#include "pair_loop.h"

namespace disc
{

struct alignas(16) Inertia {    // both 0 for a grain that does not move
  double mass, inverse_moment;
};

struct HalfKick {    // v -> scaling v + dt F/m
  double dt = 0.0;
  double gravity[2] = {0.0, 0.0};      // acceleration; every force sum starts with the weight of its grain
  double v_scaling[2] = {1.0, 1.0};    // from the background damping and the momentum convention
  double omega_scaling = 1.0;
};

struct Drift {    // x -> origin + cell_scaling (x - origin) + dt v
  double origin[2] = {0.0, 0.0}, cell_scaling[2] = {1.0, 1.0}, dt[2] = {0.0, 0.0};
};

struct StepSums {
  double mvx2 = 0.0, mvy2 = 0.0;       // sums of m v_x^2 and m v_y^2 at the full step, between the two half kicks
  double scaled[2] = {0.0, 0.0};       // sum of m v^2 + I w^2 before the scaling of the final and the initial half kick
  double max_displacement_sq = 0.0;    // bound on the displacements beyond the affine motion, squared
  double displacement_sq_sum = 0.0;    // NaN if any displacement is
};

/* One pass over the grains.  FINAL: the half kick that ends a step (LAMMPS's final_integrate), with the kinetic sums.
   INITIAL: the half kick that begins the next one (initial_integrate); it leaves only the weight in the force sums.
   SCALED: velocities are scaled before each half kick.  DRIFT: positions move; CELL: with the cell. */
template <bool FINAL, bool INITIAL, bool SCALED, bool DRIFT, bool CELL>
DISC_WIDEST StepSums integrate(const HalfKick &kick, const Drift &drift, const Inertia *inertia, GrainForce *force,
                               Grain *grain, int count)
{
  const Vec4 dt = {0.0, 0.0, kick.dt, kick.dt}, gravity = {kick.gravity[0], kick.gravity[1], 0.0, 0.0};
  const Vec4 v_scaling = {1.0, 1.0, kick.v_scaling[0], kick.v_scaling[1]};
  const Vec4 origin = {drift.origin[0], drift.origin[1], 0.0, 0.0},
             cell_scaling = {drift.cell_scaling[0], drift.cell_scaling[1], 1.0, 1.0};
  const Vec4 drift_dt = {drift.dt[0], drift.dt[1], 0.0, 0.0};
  Vec4 mv2{}, max_sq{}, sum_sq{};
  double scaled[2] = {0.0, 0.0};
  for (int i = 0; i < count; i++) {
    Grain &g = grain[i];
    Vec4 xv = vec4(&g.x);    // x y vx vy
    if (FINAL || INITIAL) {
      const Vec4 f = vec4(&force[i].fx);    // fx fy moment tangential
      const Vec4 dv = dt * g.inverse_mass * DISC_SHUFFLE(f, f, 0, 1, 0, 1);
      const double dw = kick.dt * inertia[i].inverse_moment * (f[2] + g.r * f[3]);
      double w = g.w;
      for (int half = 0; half < FINAL + INITIAL; half++) {
        if (SCALED) {
          const double iw2 = inertia[i].inverse_moment > 0.0 ? w * w / inertia[i].inverse_moment : 0.0;
          scaled[FINAL ? half : 1] += inertia[i].mass * (xv[2] * xv[2] + xv[3] * xv[3]) + iw2;
          xv *= v_scaling;
          w *= kick.omega_scaling;
        }
        xv += dv;
        w += dw;
        if (FINAL && half == 0) mv2 += inertia[i].mass * xv * xv;
      }
      g.w = w;
      g.rw = g.r * w;
      if (INITIAL) vec4(&force[i].fx) = inertia[i].mass * gravity;
    }
    if (DRIFT) {
      const Vec4 displacement = drift_dt * DISC_SHUFFLE(xv, xv, 2, 3, 2, 3);
      xv = (CELL ? origin + cell_scaling * (xv - origin) : xv) + displacement;
      const Vec4 squares = displacement * displacement;
      max_sq = squares > max_sq ? squares : max_sq;
      sum_sq += squares;
    }
    vec4(&g.x) = xv;
  }
  return {mv2[2], mv2[3], {scaled[0], scaled[1]}, max_sq[0] + max_sq[1], sum_sq[0] + sum_sq[1]};
}

}    // namespace disc

#endif
