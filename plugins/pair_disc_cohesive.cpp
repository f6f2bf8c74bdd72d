/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_cohesive.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "update.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using H = disc::CohesiveHistory;

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
               {law.has_friction() && law.kt <= 0.0, "kt", "mu > 0 asks for friction"},
               {law.has_cohesion() && law.d0 <= 0.0, "d0", "f0 > 0 asks for an attraction of finite range"},
               {law.has_rolling() && law.kr <= 0.0, "kr", "mur > 0 asks for rolling resistance"}};
  for (const auto &rule : rules)
    if (rule.wrong)
      error->all(FLERR, "pair_coeff of disc/cohesive: keyword '{}' must be given and positive: {}", rule.needed,
                 rule.why);
}

void PairDiscCohesive::init_style()
{
  PairDisc::init_style();
  if (!allocated) error->all(FLERR, "pair_style disc/cohesive has no coefficients: use 'pair_coeff * * kn ...'");
}

void *PairDiscCohesive::extract(const char *name, int &dim)
{
  dim = 0;
  for (const Coefficient &one : coefficients())
    if (strcmp(name, one.name) == 0) return one.value;
  return nullptr;
}

/* ---- the pair loop ---- */

disc::PairSums PairDiscCohesive::compute_active_pairs(bool stress)
{
  const std::array flags = {second_order,      law.has_damping(), law.has_cohesion(), law.has_friction(),
                            law.has_rolling(), account,           law.has_dashpots()};
  return call_with_flags(flags, [&](auto second, auto damping, auto cohesion, auto friction, auto rolling,
                                    auto dissipation, auto dashpots) {
    using Kernel =
        disc::Cohesive<second(), damping(), cohesion(), friction(), rolling(), dashpots() && (friction() || rolling())>;
    return pair_loop<Kernel, dissipation()>(Kernel{law}, stress);
  });
}

/* ---- one pair, for output ---- */

double PairDiscCohesive::pair_constant(int i, int j) const
{
  return law.critical_damping(atom->rmass[i], atom->rmass[j]);
}

PairDisc::Interaction PairDiscCohesive::interaction(int c) const
{
  Interaction now = geometry(c);
  if (now.gap < 0.0) {
    now.state = CONTACT;
    now.elastic = -law.kn * now.gap;
    now.viscous = history_value(H::FN_DAMP, c);
    now.xi_t = history_value(H::XI_T, c);
    now.xi_r = history_value(H::XI_R, c);
    now.tangential = -law.kt * now.xi_t;
    now.moment = -law.kr * now.xi_r;
    constexpr double AT_LIMIT = 1.0 - 1.0e-12;    // the spring stops at its limit to within rounding
    now.sliding = law.has_friction() && std::fabs(now.tangential) >= AT_LIMIT * law.mu * now.elastic;
    now.rolling = law.has_rolling() && std::fabs(now.moment) >= AT_LIMIT * law.mur * now.elastic;
    if (law.has_dashpots()) {
      now.tangential += history_value(H::FT_DAMP, c);
      now.moment += history_value(H::MR_DAMP, c);
    }
  } else {
    now.viscous = history_value(H::FN_DAMP, c);    // what a contact that opened in this step was still due
    if (now.gap < law.cutoff_gap() || now.viscous != 0.0) now.state = DISTANT;
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
    if (law.has_friction()) e.tangential = 0.5 * law.kt * now.xi_t * now.xi_t;
    if (law.has_rolling()) e.rolling = 0.5 * law.kr * now.xi_r * now.xi_r;
  }
  e.adhesive = law.adhesive_energy(now.gap);
  return e;
}
