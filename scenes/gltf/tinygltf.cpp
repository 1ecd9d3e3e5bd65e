// The implementation of tinygltf, once. Its own warnings are not ours to fix (system header).
#include <fstream>  // its writers need it even without file access

#define TINYGLTF_IMPLEMENTATION
#include "scenes/gltf/tinygltf.hpp"
