/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_cohesive.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "update.h"
#include "utils.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

namespace
{

struct Keyword {
  const char *name;
  double disc::CohesiveLaw::*value;
};

constexpr Keyword KEYWORDS[] = {{"kn", &disc::CohesiveLaw::kn},     {"kt", &disc::CohesiveLaw::kt},
                                {"zeta", &disc::CohesiveLaw::zeta}, {"mu", &disc::CohesiveLaw::mu},
                                {"f0", &disc::CohesiveLaw::f0},     {"d0", &disc::CohesiveLaw::d0},
                                {"kr", &disc::CohesiveLaw::kr},     {"mur", &disc::CohesiveLaw::mur}};

}    // namespace

/* ---- coefficients ---- */

void PairDiscCohesive::coeff(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "*") != 0 || strcmp(arg[1], "*") != 0)
    error->all(FLERR, "pair_coeff of disc/cohesive must start with '* *': one material for all grains");
  law = disc::CohesiveLaw();
  for (int k = 2; k < narg; k += 2) {
    double disc::CohesiveLaw::*value = nullptr;
    for (const Keyword &keyword : KEYWORDS)
      if (strcmp(arg[k], keyword.name) == 0) value = keyword.value;
    if (!value)
      error->all(FLERR, "pair_coeff of disc/cohesive: unknown keyword '{}'; known are: kn kt zeta mu f0 d0 kr mur",
                 arg[k]);
    if (k + 1 >= narg) error->all(FLERR, "pair_coeff of disc/cohesive: keyword '{}' needs a value", arg[k]);
    law.*value = utils::numeric(FLERR, arg[k + 1], false, lmp);
  }
  check();
  allocate();
}

void PairDiscCohesive::check() const
{
  for (const Keyword &keyword : KEYWORDS)
    if (!(law.*(keyword.value) >= 0.0))
      error->all(FLERR, "pair_coeff of disc/cohesive: {} = {} must not be negative", keyword.name,
                 law.*(keyword.value));
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

void PairDiscCohesive::allocate()
{
  const int n = atom->ntypes + 1;
  if (!allocated) {
    memory->create(setflag, n, n, "pair:setflag");
    memory->create(cutsq, n, n, "pair:cutsq");
  }
  allocated = 1;
  for (int i = 1; i < n; i++)
    for (int j = i; j < n; j++)
      setflag[i][j] = 1;
}

void PairDiscCohesive::init_style()
{
  PairDisc::init_style();
  history->second_order = second_order;
  history->turned = -1.0;    // dtheta seen from the other grain is the opposite
  if (!allocated) error->all(FLERR, "pair_style disc/cohesive has no coefficients: use 'pair_coeff * * kn ...'");
}

double PairDiscCohesive::init_one(int, int)
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    largest = std::fmax(largest, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return 2.0 * largest + law.range();
}

void *PairDiscCohesive::extract(const char *name, int &dim)
{
  dim = 0;
  for (const Keyword &keyword : KEYWORDS)
    if (strcmp(name, keyword.name) == 0) return &(law.*(keyword.value));
  return nullptr;
}

void PairDiscCohesive::write_restart(FILE *fp)
{
  fwrite(&law, sizeof(law), 1, fp);
  fwrite(&account, sizeof(account), 1, fp);
  fwrite(&second_order, sizeof(second_order), 1, fp);
}

void PairDiscCohesive::read_restart(FILE *fp)
{
  if (comm->me == 0) {
    utils::sfread(FLERR, &law, sizeof(law), 1, fp, nullptr, error);
    utils::sfread(FLERR, &account, sizeof(account), 1, fp, nullptr, error);
    utils::sfread(FLERR, &second_order, sizeof(second_order), 1, fp, nullptr, error);
  }
  MPI_Bcast(&law, sizeof(law), MPI_BYTE, 0, world);
  MPI_Bcast(&account, sizeof(account), MPI_BYTE, 0, world);
  MPI_Bcast(&second_order, sizeof(second_order), MPI_BYTE, 0, world);
  allocate();
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
  const bool flags[FLAGS] = {second_order, law.damping(), law.cohesion(), law.friction(), law.rolling(), account};
  return (this->*choose<>(flags))(stress);
}

template <bool SECOND, bool DAMPING, bool COHESION, bool FRICTION, bool ROLLING, bool ACCOUNT>
disc::Sums PairDiscCohesive::kernel(bool stress)
{
  const disc::Cohesive<SECOND, DAMPING, COHESION, FRICTION, ROLLING> cohesive{law};
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
  } else if (law.cohesion() && now.gap < law.d0) {
    now.state = DISTANT;
  }
  if (now.state != APART) now.attraction = law.attraction(now.gap);
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
