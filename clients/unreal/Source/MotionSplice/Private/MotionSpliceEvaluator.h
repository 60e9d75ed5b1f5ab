// Includes motionsplice.hpp without Unreal's macros and warnings.
#pragma once

#include "CoreMinimal.h"

#if !__has_include("motionsplice.hpp")
#error "Copy clients/cpp/motionsplice.hpp of the motionsplice repository into the folder of this file"
#endif

THIRD_PARTY_INCLUDES_START
#pragma push_macro("check")
#pragma push_macro("verify")
#pragma push_macro("near") // of windows.h
#undef check
#undef verify
#undef near
#include "motionsplice.hpp"
#pragma pop_macro("near")
#pragma pop_macro("verify")
#pragma pop_macro("check")
THIRD_PARTY_INCLUDES_END
