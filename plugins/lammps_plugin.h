/* SPDX-License-Identifier: GPL-2.0-or-later
   What a plugin needs to register with LAMMPS; the header that would say it is not part of the installed engine. */

#ifndef DISC_LAMMPS_PLUGIN_H
#define DISC_LAMMPS_PLUGIN_H

#include "error.h"
#include "lammps.h"
#include "library.h"
#include "pair.h"
#include "utils.h"

#include <dlfcn.h>

extern "C" {
struct lammpsplugin_t {
  const char *version, *style, *name, *info, *author;
  union {
    void *(*v1)(LAMMPS_NS::LAMMPS *);
    void *(*v2)(LAMMPS_NS::LAMMPS *, int, char **);
  } creator;
  void *handle;
};
using lammpsplugin_regfunc = void (*)(lammpsplugin_t *, void *);

__attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle, void *regfunc);
}

/* A style is a class of LAMMPS: its layout and its virtual functions are those of one version.  An error, before
   anything is registered, if the engine is of another one. */
inline void require_version(void *lmp, const char *built_for)
{
  const int running = lammps_version(lmp), wanted = LAMMPS_NS::utils::date2num(built_for);
  if (running != wanted)
    static_cast<LAMMPS_NS::LAMMPS *>(lmp)->error->all(
        FLERR, "the plugin was built for LAMMPS {} (version {}), this is version {}: build it for this one", built_for,
        wanted, running);
}

template <class Style> void *create_pair(LAMMPS_NS::LAMMPS *lmp)
{
  return static_cast<LAMMPS_NS::Pair *>(new Style(lmp));
}

/* LAMMPS unloads plugins while styles made from them are still alive; code that stays mapped makes that harmless. */
static void stay_loaded()
{
  Dl_info self;
  if (dladdr(reinterpret_cast<void *>(&stay_loaded), &self)) dlopen(self.dli_fname, RTLD_NOW | RTLD_NODELETE);
}

#endif
