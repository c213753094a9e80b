// A program for the precompiled header of tests/CMakeLists.txt.
