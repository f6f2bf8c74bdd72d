/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_continuous.h"

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
using disc::ContinuousBlock;
using disc::ContinuousLaw;
using disc::Neighbours;

namespace
{

struct Keyword {
  const char *name;
  double ContinuousLaw::*value;
};

constexpr Keyword KEYWORDS[] = {{"force", &ContinuousLaw::force},
                                {"index", &ContinuousLaw::index},
                                {"cutoff", &ContinuousLaw::cutoff},
                                {"hooke", &ContinuousLaw::hooke},
                                {"mu", &ContinuousLaw::mu},
                                {"alpha", &ContinuousLaw::alpha},
                                {"damping", &ContinuousLaw::damping},
                                {"printed_rotation", &ContinuousLaw::printed_rotation},
                                {"printed_damping", &ContinuousLaw::printed_damping}};
constexpr int FLAGS = 4;

}    // namespace

/* ---- coefficients ---- */

void PairDiscContinuous::settings(int narg, char **arg)
{
  account = true;
  if (narg == 0) return;
  if (narg != 2 || strcmp(arg[0], "account") != 0)
    error->all(FLERR, "pair_style disc/continuous: '{}' is not known; known is: account yes|no", arg[0]);
  account = utils::logical(FLERR, arg[1], false, lmp);
}

void PairDiscContinuous::coeff(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "*") != 0 || strcmp(arg[1], "*") != 0)
    error->all(FLERR, "pair_coeff of disc/continuous must start with '* *': one material for all grains");
  law = ContinuousLaw();
  for (int k = 2; k < narg; k += 2) {
    double ContinuousLaw::*value = nullptr;
    for (const Keyword &keyword : KEYWORDS)
      if (strcmp(arg[k], keyword.name) == 0) value = keyword.value;
    if (!value)
      error->all(FLERR,
                 "pair_coeff of disc/continuous: unknown keyword '{}'; known are: force index cutoff hooke mu alpha "
                 "damping printed_rotation printed_damping",
                 arg[k]);
    if (k + 1 >= narg) error->all(FLERR, "pair_coeff of disc/continuous: keyword '{}' needs a value", arg[k]);
    law.*value = utils::numeric(FLERR, arg[k + 1], false, lmp);
  }
  check();
  allocate();
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

void PairDiscContinuous::allocate()
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

void PairDiscContinuous::init_style()
{
  largest = largest_diameter();
  PairDisc::init_style();
  if (!allocated) error->all(FLERR, "pair_style disc/continuous has no coefficients: use 'pair_coeff * * index ...'");
}

double PairDiscContinuous::largest_diameter() const
{
  double found = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    found = std::max(found, 2.0 * atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_DOUBLE, MPI_MAX, world);
  return found;
}

double PairDiscContinuous::init_one(int, int) { return law.reach() * largest; }

void PairDiscContinuous::write_restart(FILE *fp)
{
  fwrite(&law, sizeof(law), 1, fp);
  fwrite(&account, sizeof(account), 1, fp);
}

void PairDiscContinuous::read_restart(FILE *fp)
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

template <bool... CHOSEN> PairDiscContinuous::Kernel PairDiscContinuous::choose(const bool *flags) const
{
  if constexpr (sizeof...(CHOSEN) == FLAGS)
    return &PairDiscContinuous::kernel<CHOSEN...>;
  else
    return flags[sizeof...(CHOSEN)] ? choose<CHOSEN..., true>(flags) : choose<CHOSEN..., false>(flags);
}

void PairDiscContinuous::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (eflag_atom || vflag_atom)
    error->all(
        FLERR,
        "pair_style disc/continuous has no per-atom energy or stress; use the contact table of compute pair/local");
  const bool flags[FLAGS] = {law.spring(), law.friction(), account, force->newton_pair != 0};
  (this->*choose<>(flags))();
  if (eflag_global) {
    tally_energy();
    pvector[5] -= pvector[1];    // what T_e took and the displacements do not hold
  }
  if (!wants_stress && !vflag_global) return;
  double sum[3] = {0.0, 0.0, 0.0};
  each([&](const Neighbours &, const Interaction &now, double weight) {
    sum[0] += weight * now.fx() * now.bx;
    sum[1] += weight * now.fy() * now.by;
    sum[2] += weight * now.fx() * now.by;
  });
  std::copy(sum, sum + 3, force_moment);
  if (vflag_global) {
    virial[0] += sum[0];
    virial[1] += sum[1];
    virial[3] += sum[2];
  }
}

template <bool SPRING, bool FRICTION, bool ACCOUNT, bool NEWTON> void PairDiscContinuous::kernel()
{
  const ContinuousLaw L = law;    // a local copy: the compiler knows that stores to f do not change it
  const double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0];
  double *const f = atom->f[0], *const torque = atom->torque[0];
  const int nlocal = atom->nlocal;
  const double dt = update->setupflag ? 0.0 : update->dt;    // no time passes in the force evaluation before a run
  const double rate_x = history->rate[0], rate_y = history->rate[1];
  const double reach = L.reach();
  disc::Loss loss;

  ContinuousBlock b;
  Neighbours *chosen[ContinuousBlock::SIZE];
  int count = 0;
  const auto respond = [&]() {
    disc::respond<SPRING, FRICTION, ACCOUNT>(L, dt, b, count);
    for (int k = 0; k < count; k++) {
      Neighbours &p = *chosen[k];
      const int i = 3 * p.i, j = 3 * p.j;
      p.viscous = b.viscous[k];
      f[i] -= b.fx[k];
      f[i + 1] -= b.fy[k];
      if (FRICTION) {
        p.springs = {b.stretch[k], b.dragging[k]};
        torque[i + 2] -= p.ri * b.torque[k];
      }
      if (NEWTON || p.j < nlocal) {
        f[j] += b.fx[k];
        f[j + 1] += b.fy[k];
        if (FRICTION) torque[j + 2] -= p.rj * b.torque[k];
      }
      if (ACCOUNT) {
        const double weight = NEWTON || p.j < nlocal ? 1.0 : 0.5;
        loss.viscous += weight * b.lost_viscous[k];
        if (FRICTION) loss.sliding += weight * b.lost_sliding[k];
      }
    }
    count = 0;
  };

  for (Neighbours &p : history->pairs) {
    const int i = 3 * p.i, j = 3 * p.j;
    const double bx = x[j] - x[i], by = x[j + 1] - x[i + 1];
    const double touch = p.ri + p.rj, r0 = reach * touch;
    if (bx * bx + by * by >= r0 * r0) {
      if (p.remembers()) p.forget();    // most were apart before: do not make the cache write them back
      continue;
    }
    chosen[count] = &p;
    b.bx[count] = bx;
    b.by[count] = by;
    b.touch[count] = touch;
    b.eta[count] = p.eta;
    b.ux[count] = v[j] - v[i] + rate_x * bx;
    b.uy[count] = v[j + 1] - v[i + 1] + rate_y * by;
    if (FRICTION) {
      b.surface[count] = p.ri * w[i + 2] + p.rj * w[j + 2];
      b.stretch[count] = p.springs.stretch;
    }
    if (++count == ContinuousBlock::SIZE) respond();
  }
  respond();
  history->loss.viscous += loss.viscous;
  history->loss.sliding += loss.sliding;
}

/* ---- one pair, for output ---- */

/* sqrt(m) of the damping C = sqrt(m k), m = 2 m*: the mass of each of two equal grains */
double PairDiscContinuous::viscosity(int i, int j) const
{
  const double mi = atom->rmass[i], mj = atom->rmass[j];
  return std::sqrt(2.0 * mi * mj / (mi + mj));
}

PairDisc::Interaction PairDiscContinuous::interaction(const Neighbours &p) const
{
  Interaction now = geometry(p);
  const double touch = p.ri + p.rj, depth = law.reach() * touch - now.distance;
  if (depth <= 0.0) return now;
  now.state = CONTACT;
  now.elastic = law.elastic(now.distance, touch);
  now.viscous = p.viscous;
  if (!law.friction()) return now;
  now.stretch = p.springs.stretch;
  const double largest = law.alpha * law.mu * depth;
  const double rest = std::max(0.0, 1.0 - std::fabs(now.stretch) / largest);
  now.tangential =
      p.springs.rotation - std::copysign(law.mu * now.elastic * (1.0 - rest * std::sqrt(rest)), now.stretch);
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
