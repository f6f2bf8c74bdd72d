/* SPDX-License-Identifier: GPL-2.0-or-later
   What a plugin needs to make itself known to LAMMPS; the header that would say it is not part of the installed engine.
 */

#ifndef DISC_LAMMPS_PLUGIN_H
#define DISC_LAMMPS_PLUGIN_H

#include "pair.h"

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
