// Gives the precompiled header of tests/CMakeLists.txt a program to belong to.
