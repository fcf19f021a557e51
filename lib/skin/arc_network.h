#pragma once

#include "skin/arcs.h"
