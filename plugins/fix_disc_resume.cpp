/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_resume.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "pair.h"
#include "rank_sums.h"
#include "update.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

FixDiscResume::FixDiscResume(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg != 3) error->all(FLERR, "fix disc/resume takes no arguments, not '{}'", arg[3]);
  if (igroup != 0) error->all(FLERR, "fix disc/resume keeps the forces of every grain: its group must be 'all'");
  restart_global = restart_peratom = 1;
  FixDiscResume::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

FixDiscResume::~FixDiscResume()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
}

int FixDiscResume::setmask() { return FixConst::PRE_EXCHANGE; }    // for its setup

bool FixDiscResume::continues() const { return update->ntimestep == step; }

/* LAMMPS stores the time of this step; rounding differs from that of the run that counts on. */
void FixDiscResume::setup_pre_exchange()
{
  if (!continues()) return;
  update->atime = time;
  update->atimestep = since;
}

void FixDiscResume::setup(int)
{
  if (!continues()) return;
  for (int i = 0; i < atom->nlocal; i++) {
    atom->f[i][0] = restored[i].fx;
    atom->f[i][1] = restored[i].fy;
    atom->torque[i][2] = restored[i].moment;
  }
  std::copy(virial.begin(), virial.end(), force->pair->virial);
}

int FixDiscResume::modify_param(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "forces") != 0 || strcmp(arg[1], "anew") != 0) return 0;
  step = -1;
  return 2;
}

/* ---- per-atom bookkeeping of LAMMPS ---- */

void FixDiscResume::grow_arrays(int nmax)
{
  if (static_cast<int>(restored.size()) < nmax) restored.resize(nmax);
}

void FixDiscResume::copy_arrays(int i, int j, int /*delflag*/) { restored[j] = restored[i]; }

int FixDiscResume::pack_exchange(int i, double *buf)
{
  buf[0] = restored[i].fx;
  buf[1] = restored[i].fy;
  buf[2] = restored[i].moment;
  return FORCE;
}

int FixDiscResume::unpack_exchange(int i, double *buf)
{
  restored[i] = {buf[0], buf[1], buf[2], 0.0};
  return FORCE;
}

/* ---- restart ---- */

void FixDiscResume::write_restart(FILE *fp)
{
  double first = update->whichflag == 1 ? 1.0 : 0.0;    // outside a run the next one evaluates forces anew in any case
  std::vector<double> state = {first, update->atime, ubuf(update->atimestep).d};
  const double *const sums = force->pair->virial;
  save_rank_sums(world, std::vector<double>(sums, sums + VIRIAL), state);
  if (comm->me != 0) return;
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state.data(), size, 1, fp);
}

void FixDiscResume::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  step = state[0] > 0.0 ? update->ntimestep : -1;
  time = state[1];
  double counted = state[2];
  since = static_cast<bigint>(ubuf(counted).i);
  virial = restore_rank_sums(world, state + 3, VIRIAL);
}

int FixDiscResume::pack_restart(int i, double *buf)
{
  buf[0] = 1 + FORCE;
  buf[1] = atom->f[i][0];
  buf[2] = atom->f[i][1];
  buf[3] = atom->torque[i][2];
  return 1 + FORCE;
}

void FixDiscResume::unpack_restart(int nlocal, int nth)
{
  double *extra = atom->extra[nlocal];
  int m = 0;
  for (int k = 0; k < nth; k++)
    m += static_cast<int>(extra[m]);
  unpack_exchange(nlocal, extra + m + 1);
}
