#pragma once

#include "skin/features.h"
