// The whole public interface of the core library: particles to meshes, and what judges meshes.

#pragma once

#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/curves.h"
#include "betamesh/error.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/skin.h"
#include "betamesh/skin_params.h"
#include "betamesh/vec3.h"
#include "betamesh/version.h"
