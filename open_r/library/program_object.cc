#include "open_r/library/program_object.h"

#include <ObjectEntryTable.h>
#include <dlfcn.h>

namespace seam::open_r {

OID load_object(System& system, const std::string& name, const std::filesystem::path& file) {
  const OID object = system.begin_object(name);
  // RTLD_LOCAL: its names are its own. It stays for as long as the process lives.
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    throw Fault(name + ": cannot be loaded, expected an object that `seam open-r build` made: " +
                dlerror());
  const auto* table = static_cast<const ObjectEntry*>(dlsym(library, "ObjectEntryTable"));
  if (table == nullptr)
    throw Fault(file.string() +
                ": has no ObjectEntryTable, expected one in a stub: write stub.cfg, or a stub by "
                "hand");
  system.end_object(object, [table](Selector selector, void* message) {
    for (const ObjectEntry* row = table; row->selector != UNDEF; ++row)
      if (row->selector == selector) return row->entry(message);
  });
  return object;
}

}  // namespace seam::open_r
