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
using disc::Neighbours;

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

/* Sums of one force evaluation; a pair that newton off lists twice counts half each time. */
struct Tally {
  double xx = 0.0, yy = 0.0, xy = 0.0;
  disc::Loss loss;
};

constexpr int FLAGS = 7;

}    // namespace

/* ---- coefficients ---- */

void PairDiscCohesive::settings(int narg, char **arg)
{
  account = true;
  for (int k = 0; k < narg; k += 2) {
    if (strcmp(arg[k], "account") != 0)
      error->all(FLERR, "pair_style disc/cohesive: unknown keyword '{}'; known is: account yes|no", arg[k]);
    if (k + 1 >= narg) error->all(FLERR, "pair_style disc/cohesive: keyword 'account' needs a value, yes or no");
    account = utils::logical(FLERR, arg[k + 1], false, lmp);
  }
}

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
}

void PairDiscCohesive::read_restart(FILE *fp)
{
  if (comm->me == 0) {
    utils::sfread(FLERR, &law, sizeof(law), 1, fp, nullptr, error);
    utils::sfread(FLERR, &account, sizeof(account), 1, fp, nullptr, error);
  }
  MPI_Bcast(&law, sizeof(law), MPI_BYTE, 0, world);
  MPI_Bcast(&account, sizeof(account), MPI_BYTE, 0, world);
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

void PairDiscCohesive::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (eflag_atom || vflag_atom)
    error->all(
        FLERR,
        "pair_style disc/cohesive has no per-atom energy or stress; use the contact table of compute pair/local");
  const bool flags[FLAGS] = {
      law.damping(), law.cohesion(),         law.friction(), law.rolling(), wants_stress || vflag_either,
      account,       force->newton_pair != 0};
  (this->*choose<>(flags))();
  if (eflag_global) tally_energy();
  if (vflag_global) {
    virial[0] += force_moment[0];
    virial[1] += force_moment[1];
    virial[3] += force_moment[2];
  }
}

template <bool DAMPING, bool COHESION, bool FRICTION, bool ROLLING, bool STRESS, bool ACCOUNT, bool NEWTON>
void PairDiscCohesive::kernel()
{
  const disc::CohesiveLaw L = law;    // a local copy: the compiler knows that stores to f do not change it
  const double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0];
  double *const f = atom->f[0], *const torque = atom->torque[0];
  const int nlocal = atom->nlocal;
  const double dt = update->setupflag ? 0.0 : update->dt;    // no time passes in the force evaluation before a run
  const double rate_x = history->rate[0], rate_y = history->rate[1];
  Tally sum;

  disc::Block b;
  Neighbours *chosen[disc::Block::SIZE];
  int count = 0;
  const auto respond = [&]() {
    disc::respond<DAMPING, COHESION, FRICTION, ROLLING, ACCOUNT>(L, dt, b, count);
    for (int k = 0; k < count; k++) {
      Neighbours &p = *chosen[k];
      const int i = 3 * p.i, j = 3 * p.j;
      if (DAMPING) p.viscous = b.viscous[k];
      if (FRICTION) p.springs.stretch = b.stretch[k];
      if (ROLLING) p.springs.rotation = b.rotation[k];
      const double fx = b.fx[k], fy = b.fy[k];
      const double tangential = FRICTION ? b.tangential[k] : 0.0, moment = ROLLING ? b.moment[k] : 0.0;
      f[i] -= fx;
      f[i + 1] -= fy;
      if (FRICTION || ROLLING) torque[i + 2] -= p.ri * tangential + moment;
      if (NEWTON || p.j < nlocal) {
        f[j] += fx;
        f[j + 1] += fy;
        if (FRICTION || ROLLING) torque[j + 2] += moment - p.rj * tangential;
      }
      const double weight = NEWTON || p.j < nlocal ? 1.0 : 0.5;
      if (STRESS) {
        sum.xx += weight * fx * b.bx[k];
        sum.yy += weight * fy * b.by[k];
        sum.xy += weight * fx * b.by[k];
      }
      if (ACCOUNT) {
        if (DAMPING) sum.loss.viscous += weight * b.lost_viscous[k];
        if (FRICTION) sum.loss.sliding += weight * b.lost_sliding[k];
        if (ROLLING) sum.loss.rolling += weight * b.lost_rolling[k];
      }
    }
    count = 0;
  };

  for (Neighbours &p : history->pairs) {
    const int i = 3 * p.i, j = 3 * p.j;
    const double bx = x[j] - x[i], by = x[j + 1] - x[i + 1];
    const double touch = p.ri + p.rj;
    const double reach = COHESION ? touch + L.d0 : touch;
    if (bx * bx + by * by >= reach * reach) {
      if (p.remembers()) p.forget();    // most were apart before: do not make the cache write them back
      continue;
    }
    chosen[count] = &p;
    b.bx[count] = bx;
    b.by[count] = by;
    b.touch[count] = touch;
    if (DAMPING || FRICTION) {
      b.ux[count] = v[j] - v[i] + rate_x * bx;
      b.uy[count] = v[j + 1] - v[i + 1] + rate_y * by;
    }
    if (DAMPING) b.eta[count] = p.eta;
    if (FRICTION) {
      b.surface[count] = p.ri * w[i + 2] + p.rj * w[j + 2];
      b.stretch[count] = p.springs.stretch;
    }
    if (ROLLING) {
      b.spin[count] = w[j + 2] - w[i + 2];
      b.rotation[count] = p.springs.rotation;
    }
    if (++count == disc::Block::SIZE) respond();
  }
  respond();

  if (STRESS) {
    force_moment[0] = sum.xx;
    force_moment[1] = sum.yy;
    force_moment[2] = sum.xy;
  }
  if (ACCOUNT) {
    history->loss.viscous += sum.loss.viscous;
    history->loss.sliding += sum.loss.sliding;
    history->loss.rolling += sum.loss.rolling;
  }
}

/* ---- one pair, for output ---- */

double PairDiscCohesive::viscosity(int i, int j) const { return law.viscosity(atom->rmass[i], atom->rmass[j]); }

PairDisc::Interaction PairDiscCohesive::interaction(const Neighbours &p) const
{
  Interaction now = geometry(p);
  if (now.gap < 0.0) {
    now.state = CONTACT;
    now.elastic = -law.kn * now.gap;
    now.viscous = p.viscous;
    now.stretch = p.springs.stretch;
    now.rotation = p.springs.rotation;
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
