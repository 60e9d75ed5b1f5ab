#pragma once
#include "CoreMinimal.h"
class FDefaultModuleImpl
{
};
#define IMPLEMENT_MODULE(implementation, name) static_assert(sizeof(implementation) > 0, #name);
