/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc_tail.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "keywords.h"
#include "memory.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "utils.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

PairDiscTail::PairDiscTail(LAMMPS *lmp) : Pair(lmp)
{
  restartinfo = 1;
  one_coeff = 1;
  single_enable = 1;
  finitecutflag = 1;
}

PairDiscTail::~PairDiscTail()
{
  if (!allocated) return;
  memory->destroy(setflag);
  memory->destroy(cutsq);
}

void PairDiscTail::settings(int narg, char **arg)
{
  if (narg) error->all(FLERR, "pair_style disc/tail takes no arguments, got '{}'", arg[0]);
}

void PairDiscTail::coeff(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "*") != 0 || strcmp(arg[1], "*") != 0)
    error->all(FLERR, "pair_coeff of disc/tail must start with '* *': one material for all grains");
  f0 = d0 = 0.0;
  Keywords(lmp, "pair_coeff of disc/tail", {number("f0", f0), number("d0", d0)}).parse(2, narg, arg);
  if (!(f0 >= 0.0)) error->all(FLERR, "pair_coeff of disc/tail: f0 = {} must not be negative", f0);
  if (!(d0 > 0.0)) error->all(FLERR, "pair_coeff of disc/tail: d0 = {} must be given and positive", d0);
  allocate();
}

void PairDiscTail::allocate()
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

void PairDiscTail::init_style()
{
  if (!atom->radius_flag) error->all(FLERR, "pair_style disc/tail needs radii: use 'atom_style sphere'");
  neighbor->add_request(this);
}

double PairDiscTail::init_one(int, int)
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    largest = std::fmax(largest, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return 2.0 * largest + d0;
}

double PairDiscTail::attraction(double gap) const { return gap < 0.0 ? f0 : gap < d0 ? f0 * (1.0 - gap / d0) : 0.0; }

double PairDiscTail::energy(double gap) const
{
  if (gap < 0.0) return f0 * (gap - 0.5 * d0);
  return gap < d0 ? -0.5 * f0 * (d0 - gap) * (d0 - gap) / d0 : 0.0;
}

void PairDiscTail::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  double **const x = atom->x, **const f = atom->f;
  const double *const radius = atom->radius;
  const int nlocal = atom->nlocal, newton = force->newton_pair;
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1];
      const double radsum = radius[i] + radius[j], cutoff = radsum + d0, square = dx * dx + dy * dy;
      if (square >= cutoff * cutoff) continue;
      const double distance = std::sqrt(square), gap = distance - radsum;
      const double along = -attraction(gap) / distance;
      f[i][0] += along * dx;
      f[i][1] += along * dy;
      if (newton || j < nlocal) {
        f[j][0] -= along * dx;
        f[j][1] -= along * dy;
      }
      if (evflag) ev_tally(i, j, nlocal, newton, energy(gap), 0.0, along, dx, dy, 0.0);
    }
  }
  if (vflag_fdotr) virial_fdotr_compute();
}

double PairDiscTail::single(int i, int j, int, int, double square, double, double, double &fforce)
{
  const double distance = std::sqrt(square), gap = distance - atom->radius[i] - atom->radius[j];
  fforce = -attraction(gap) / distance;
  return energy(gap);
}

void PairDiscTail::write_restart(FILE *fp)
{
  const double both[2] = {f0, d0};
  fwrite(both, sizeof(both), 1, fp);
}

void PairDiscTail::read_restart(FILE *fp)
{
  double both[2];
  if (comm->me == 0) utils::sfread(FLERR, both, sizeof(both), 1, fp, nullptr, error);
  MPI_Bcast(both, 2, MPI_DOUBLE, 0, world);
  f0 = both[0];
  d0 = both[1];
  allocate();
}
