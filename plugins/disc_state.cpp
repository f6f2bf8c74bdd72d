/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "disc_state.h"

#include "atom.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;
using disc::Grain;

void DiscState::load(int from, int to)
{
  const double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0], *const r = atom->radius,
                      *const m = atom->rmass;
  for (int i = from, k = 3 * from; i < to; i++, k += 3)
    grains[i] = {x[k],     x[k + 1],        v[k], v[k + 1],
                 w[k + 2], r[i] * w[k + 2], r[i], atom->mask[i] & fixed ? 0.0 : 1.0 / m[i]};
}

void DiscState::load_forces()
{
  const double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3)
    forces[i] = {f[k], f[k + 1], torque[k + 2], 0.0};
}

void DiscState::store() const
{
  double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3) {
    const Grain &g = grains[i];
    x[k] = g.x;
    x[k + 1] = g.y;
    v[k] = g.vx;
    v[k + 1] = g.vy;
    w[k + 2] = g.w;
  }
}

void DiscState::store_forces() const
{
  double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3) {
    const disc::GrainForce &sum = forces[i];
    f[k] = sum.fx;
    f[k + 1] = sum.fy;
    torque[k + 2] = sum.moment + grains[i].r * sum.tangential;
  }
}

void DiscState::resize()
{
  grains.resize(atom->nlocal + atom->nghost);
  forces.resize(atom->nlocal + atom->nghost);
  reset_forces();
}

void DiscState::reset_forces()
{
  std::fill(forces.begin(), forces.end(), disc::GrainForce());
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & fixed)) {
      forces[i].fx = atom->rmass[i] * gravity[0];
      forces[i].fy = atom->rmass[i] * gravity[1];
    }
}

void DiscState::set_kinematics(const double *cell_scaling, bool second_order)
{
  const double dt = update->dt;
  kinematics.dt = dt;
  for (int a = 0; a < 2; a++) {
    const double s = cell_scaling[a], mean = 0.5 * (1.0 + s);
    kinematics.velocity_factor[a] = second_order ? mean / s : 1.0;
    kinematics.affine_rate[a] = (s - 1.0) / ((second_order ? s : mean) * dt);
  }
  kinematics.extrapolation = second_order ? 0.5 : 0.0;
}

void DiscState::stop_kinematics()
{
  kinematics.dt = kinematics.extrapolation = 0.0;
  kinematics.velocity_factor[0] = kinematics.velocity_factor[1] = 1.0;
}

void DiscState::add_sums(const disc::PairSums &sums)
{
  dissipated.viscous += sums.viscous;
  dissipated.sliding += sums.sliding;
  dissipated.rolling += sums.rolling;
  extremes.overlap = std::max(extremes.overlap, sums.overlap);
  extremes.approach = std::max(extremes.approach, sums.approach);
  extremes.advance = std::max(extremes.advance, sums.approach * kinematics.dt);
}

disc::Extremes DiscState::global_extremes() const
{
  double largest[3] = {extremes.overlap, extremes.approach, extremes.advance};
  MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPI_DOUBLE, MPI_MAX, world);
  return {largest[0], largest[1], largest[2]};
}

double DiscState::memory_usage() const
{
  return static_cast<double>(grains.capacity() * sizeof(Grain) + forces.capacity() * sizeof(disc::GrainForce));
}
