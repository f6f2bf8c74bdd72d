/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_continuous.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;

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
               {law.friction() && !(law.alpha > 0.0), "alpha", "positive with friction", law.alpha},
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
  history->second_order = second_order;
  history->turned = 1.0;    // T is the same seen from both grains
  if (!allocated) error->all(FLERR, "pair_style disc/continuous has no coefficients: use 'pair_coeff * * index ...'");
}

double PairDiscContinuous::init_one(int, int) { return law.reach() * largest; }

/* ---- the loop ---- */

template <bool... CHOSEN> PairDiscContinuous::Kernel PairDiscContinuous::choose(const bool *flags) const
{
  if constexpr (sizeof...(CHOSEN) == FLAGS)
    return &PairDiscContinuous::kernel<CHOSEN...>;
  else
    return flags[sizeof...(CHOSEN)] ? choose<CHOSEN..., true>(flags) : choose<CHOSEN..., false>(flags);
}

disc::Sums PairDiscContinuous::sweep(bool stress)
{
  const bool flags[FLAGS] = {second_order, law.spring(), law.friction(), account};
  return (this->*choose<>(flags))(stress);
}

template <bool SECOND, bool SPRING, bool FRICTION, bool ACCOUNT> disc::Sums PairDiscContinuous::kernel(bool stress)
{
  const disc::Continuous<SECOND, SPRING, FRICTION> continuous{law};
  return disc::sweep<decltype(continuous), ACCOUNT>(continuous, history->motion, history->grains.data(), atom->nlocal,
                                                    !force->newton_pair, stress, history->close,
                                                    history->actions.data());
}

void PairDiscContinuous::compute(int eflag, int vflag)
{
  PairDisc::compute(eflag, vflag);
  if (eflag_global) pvector[5] -= pvector[1];    // what T_e took and the displacements do not hold
}

/* ---- one pair, for output ---- */

/* sqrt(m) of the damping C = sqrt(m k), m = 2 m*: the mass of each of two equal grains */
double PairDiscContinuous::viscosity(int i, int j) const
{
  const double mi = atom->rmass[i], mj = atom->rmass[j];
  return std::sqrt(2.0 * mi * mj / (mi + mj));
}

PairDisc::Interaction PairDiscContinuous::interaction(int c) const
{
  Interaction now = geometry(c);
  const double touch = now.distance - now.gap, depth = law.reach() * touch - now.distance;
  if (depth <= 0.0) return now;
  now.state = CONTACT;
  now.elastic = law.elastic(now.distance, touch);
  now.viscous = history->close.viscous[c];
  if (!law.friction()) return now;
  now.stretch = history->close.stretch[c];
  const double largest = law.alpha * law.mu * depth;
  const double rest = 1.0 - std::fabs(now.stretch) / largest;
  now.tangential = history->close.rotation[c];
  now.sliding = rest < 1.0e-12;    // d stops at its limit to within rounding
  return now;
}

PairDisc::Energy PairDiscContinuous::energy(const Interaction &now) const
{
  Energy e;
  if (now.state == APART) return e;
  const double touch = now.distance - now.gap;
  e.elastic = law.potential(now.distance, touch);
  if (law.friction())
    e.tangential = law.tangential_energy(now.elastic, law.reach() * touch - now.distance, now.stretch);
  return e;
}
