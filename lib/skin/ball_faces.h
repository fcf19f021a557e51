#pragma once

#include "skin/faces.h"
