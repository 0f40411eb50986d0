/// For builds with the address sanitizer: what VTK 9.1 loses by itself, for tests to link in.

extern "C" const char* __lsan_default_suppressions();

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtkIOXML\n"                                            // its writers, when the disk is full
         "leak:vtkGeometryFilterHelper::CharacterizeUnstructuredGrid\n"; // a byte per surface
}
