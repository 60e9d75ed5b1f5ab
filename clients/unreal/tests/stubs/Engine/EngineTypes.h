#pragma once
#include "CoreMinimal.h"
struct FDirectoryPath
{
	FString Path;
};
