/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_continuous.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;
using H = disc::ContinuousHistory;

/* ---- coefficients ---- */

void PairDiscContinuous::coeff(int narg, char **arg)
{
  law = disc::ContinuousLaw();
  read_coefficients(narg, arg,
                    {{"force", &law.force},
                     {"index", &law.index},
                     {"cutoff", &law.cutoff},
                     {"hooke", &law.hooke},
                     {"mu", &law.mu},
                     {"alpha", &law.alpha},
                     {"damping", &law.damping},
                     {"printed_rotation", &law.printed_rotation},
                     {"printed_damping", &law.printed_damping}});
  check();
}

void PairDiscContinuous::check() const
{
  const struct {
    bool wrong;
    const char *name, *allowed;
    double value;
  } rules[] = {{!(law.force > 0.0), "force", "positive", law.force},
               {!(law.index > 0.0), "index", "positive", law.index},
               {!(law.cutoff >= 1.0), "cutoff", "at least 1 (r0 in units of sigma)", law.cutoff},
               {!(law.hooke >= 0.0), "hooke", "positive, or 0 for the continuous law", law.hooke},
               {!(law.mu >= 0.0), "mu", "0 or positive", law.mu},
               {law.has_friction() && !(law.alpha > 0.0), "alpha", "positive with friction", law.alpha},
               {!(law.damping >= 0.0), "damping", "0 or positive", law.damping}};
  for (const auto &rule : rules)
    if (rule.wrong)
      error->all(FLERR, "pair_coeff of disc/continuous: {} = {} must be {}", rule.name, rule.value, rule.allowed);
  for (const double flag : {law.printed_rotation, law.printed_damping})
    if (flag != 0.0 && flag != 1.0)
      error->all(FLERR, "pair_coeff of disc/continuous: printed_rotation and printed_damping must be 0 or 1, not {}",
                 flag);
}

void PairDiscContinuous::init_style()
{
  largest = largest_diameter();
  PairDisc::init_style();
  if (!allocated) error->all(FLERR, "pair_style disc/continuous has no coefficients: use 'pair_coeff * * index ...'");
}

double PairDiscContinuous::init_one(int, int) { return law.cutoff_ratio() * largest; }

/* ---- the pair loop ---- */

disc::PairSums PairDiscContinuous::compute_active_pairs(bool stress)
{
  const std::array flags = {second_order, law.spring(), law.has_friction(), account};
  return call_with_flags(flags, [&](auto second, auto spring, auto friction, auto dissipation) {
    using Kernel = disc::Continuous<second(), spring(), friction()>;
    return pair_loop<Kernel, dissipation()>(Kernel{law}, stress);
  });
}

void PairDiscContinuous::compute(int eflag, int vflag)
{
  PairDisc::compute(eflag, vflag);
  if (eflag_global) pvector[D_SLIDING] -= pvector[E_TANGENTIAL];    // what T_e took and the displacements do not hold
}

/* ---- one pair, for output ---- */

/* sqrt(m) of the damping C = sqrt(m k), m = 2 m*: the mass of each of two equal grains */
double PairDiscContinuous::pair_constant(int i, int j) const
{
  const double mi = atom->rmass[i], mj = atom->rmass[j];
  return std::sqrt(2.0 * mi * mj / (mi + mj));
}

PairDisc::Interaction PairDiscContinuous::interaction(int c) const
{
  Interaction now = geometry(c);
  const double radsum = now.distance - now.gap, depth = law.cutoff_ratio() * radsum - now.distance;
  if (depth <= 0.0) return now;
  now.state = CONTACT;
  now.elastic = law.elastic(now.distance, radsum);
  now.viscous = history_value(H::FN_DAMP, c);
  if (!law.has_friction()) return now;
  now.xi_t = history_value(H::XI_T, c);
  const double largest = law.alpha * law.mu * depth;
  const double rest = 1.0 - std::fabs(now.xi_t) / largest;
  now.tangential = history_value(H::FT, c);
  now.sliding = rest < 1.0e-12;    // xi_t stops at its limit to within rounding
  return now;
}

PairDisc::Energy PairDiscContinuous::energy(const Interaction &now) const
{
  Energy e;
  if (now.state == APART) return e;
  const double radsum = now.distance - now.gap;
  e.elastic = law.potential(now.distance, radsum);
  if (law.has_friction())
    e.tangential = law.tangential_energy(now.elastic, law.cutoff_ratio() * radsum - now.distance, now.xi_t);
  return e;
}
