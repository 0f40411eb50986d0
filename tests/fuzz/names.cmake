# The readers that have a fuzzer: read_NAME of readers.cpp, with its inputs in corpus/NAME.
set(fuzzed_readers colour_map dicom events field_file jpeg json landmarks look material meta_image nifti nrrd obj picture recorded_motion scene
  study study_table surface tissue trajectory vti world)
