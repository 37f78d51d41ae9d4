// As core_macro.h, for an object whose services begin with a name that it gives itself: `myname`.
#ifndef SEAM_OPEN_R_CORE_MACRO2_H
#define SEAM_OPEN_R_CORE_MACRO2_H

#include <OPENR/core_macro.h>

#include <string>

// "Class.Name.Data.S" -> "myname.Name.Data.S"
inline std::string SeamServiceOf(const std::string& name, const char* service) {
  const std::string whole(service);
  return name + whole.substr(whole.find('.'));
}

#undef REGISTER_ALL_ENTRY
#define REGISTER_ALL_ENTRY                                                                      \
  do {                                                                                          \
    SEAM_OPEN_R_EACH(numOfSubject,                                                              \
                     RegisterServiceEntry(OServiceEntry(myOID_, Entry_Control[i_]),             \
                                          SeamServiceOf(myname, subjectService[i_]).c_str()));  \
    SEAM_OPEN_R_EACH(numOfObserver,                                                             \
                     RegisterServiceEntry(OServiceEntry(myOID_, Entry_Connect[i_]),             \
                                          SeamServiceOf(myname, observerService[i_]).c_str())); \
  } while (0)

#endif
