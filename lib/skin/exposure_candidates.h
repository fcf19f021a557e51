#pragma once

#include "skin/coverage.h"
