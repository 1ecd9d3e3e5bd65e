// tinygltf 2.7 as this folder uses it: no image codec, no file access of its own (see document.cpp), JSON
// from the system. Included by .cpp files of this folder only.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
