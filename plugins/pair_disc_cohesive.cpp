/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_cohesive.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

/* ---- coefficients ---- */

std::vector<PairDisc::Coefficient> PairDiscCohesive::coefficients()
{
  return {{"kn", &law.kn}, {"kt", &law.kt}, {"zeta", &law.zeta}, {"mu", &law.mu},       {"f0", &law.f0},
          {"d0", &law.d0}, {"kr", &law.kr}, {"mur", &law.mur},   {"zetat", &law.zetat}, {"zetar", &law.zetar}};
}

void PairDiscCohesive::coeff(int narg, char **arg)
{
  law = disc::CohesiveLaw();
  read_coefficients(narg, arg, coefficients());
  check();
}

void PairDiscCohesive::check()
{
  for (const Coefficient &one : coefficients())
    if (!(*one.value >= 0.0))
      error->all(FLERR, "pair_coeff of disc/cohesive: {} = {} must not be negative", one.name, *one.value);
  const struct {
    bool wrong;
    const char *needed, *why;
  } rules[] = {{law.kn <= 0.0, "kn", "it is the normal stiffness"},
               {law.friction() && law.kt <= 0.0, "kt", "mu > 0 asks for friction"},
               {law.cohesion() && law.d0 <= 0.0, "d0", "f0 > 0 asks for an attraction of finite range"},
               {law.rolling() && law.kr <= 0.0, "kr", "mur > 0 asks for rolling resistance"}};
  for (const auto &rule : rules)
    if (rule.wrong)
      error->all(FLERR, "pair_coeff of disc/cohesive: keyword '{}' must be given and positive: {}", rule.needed,
                 rule.why);
}

void PairDiscCohesive::init_style()
{
  PairDisc::init_style();
  history->second_order = second_order;
  history->turned = -1.0;    // dtheta seen from the other grain is the opposite
  if (!allocated) error->all(FLERR, "pair_style disc/cohesive has no coefficients: use 'pair_coeff * * kn ...'");
}

void *PairDiscCohesive::extract(const char *name, int &dim)
{
  dim = 0;
  for (const Coefficient &one : coefficients())
    if (strcmp(name, one.name) == 0) return one.value;
  return nullptr;
}

/* ---- the loop ---- */

/* Turns run-time flags into the kernel compiled for exactly that combination. */
template <bool... CHOSEN> PairDiscCohesive::Kernel PairDiscCohesive::choose(const bool *flags) const
{
  if constexpr (sizeof...(CHOSEN) == FLAGS)
    return &PairDiscCohesive::kernel<CHOSEN...>;
  else
    return flags[sizeof...(CHOSEN)] ? choose<CHOSEN..., true>(flags) : choose<CHOSEN..., false>(flags);
}

disc::Sums PairDiscCohesive::sweep(bool stress)
{
  const bool flags[FLAGS] = {second_order,  law.damping(), law.cohesion(), law.friction(),
                             law.rolling(), account,       law.dashpots()};
  return (this->*choose<>(flags))(stress);
}

template <bool SECOND, bool DAMPING, bool COHESION, bool FRICTION, bool ROLLING, bool ACCOUNT, bool DASHPOTS>
disc::Sums PairDiscCohesive::kernel(bool stress)
{
  const disc::Cohesive<SECOND, DAMPING, COHESION, FRICTION, ROLLING, DASHPOTS && (FRICTION || ROLLING)> cohesive{law};
  return disc::sweep<decltype(cohesive), ACCOUNT>(cohesive, history->motion, history->grains.data(), atom->nlocal,
                                                  !force->newton_pair, stress, history->close, history->actions.data());
}

/* ---- one pair, for output ---- */

double PairDiscCohesive::viscosity(int i, int j) const { return law.viscosity(atom->rmass[i], atom->rmass[j]); }

PairDisc::Interaction PairDiscCohesive::interaction(int c) const
{
  Interaction now = geometry(c);
  if (now.gap < 0.0) {
    now.state = CONTACT;
    now.elastic = -law.kn * now.gap;
    now.viscous = history->close.viscous[c];
    now.stretch = history->close.stretch[c];
    now.rotation = history->close.rotation[c];
    now.tangential = -law.kt * now.stretch;
    now.moment = -law.kr * now.rotation;
    constexpr double AT_LIMIT = 1.0 - 1.0e-12;    // the slider stops on the cone to within rounding
    now.sliding = law.friction() && std::fabs(now.tangential) >= AT_LIMIT * law.mu * now.elastic;
    now.rolling = law.rolling() && std::fabs(now.moment) >= AT_LIMIT * law.mur * now.elastic;
    if (law.dashpots()) {
      now.tangential += history->close.viscous_t[c];
      now.moment += history->close.viscous_r[c];
    }
  } else {
    now.viscous = history->close.viscous[c];    // what a contact that opened in this step was still due
    if (now.gap < law.range() || now.viscous != 0.0) now.state = DISTANT;
  }
  now.attraction = law.attraction(now.gap);
  return now;
}

PairDisc::Energy PairDiscCohesive::energy(const Interaction &now) const
{
  Energy e;
  if (now.state == APART) return e;
  if (now.state == CONTACT) {
    e.elastic = 0.5 * law.kn * now.gap * now.gap;
    if (law.friction()) e.tangential = 0.5 * law.kt * now.stretch * now.stretch;
    if (law.rolling()) e.rolling = 0.5 * law.kr * now.rotation * now.rotation;
  }
  e.adhesive = law.adhesive_energy(now.gap);
  return e;
}
