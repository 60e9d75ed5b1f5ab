#pragma once
#include "Engine/EngineTypes.h"
