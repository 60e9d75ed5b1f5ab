#pragma once
#include "CoreMinimal.h"

struct FPaths
{
	static FString ProjectDir() { return TEXT("."); }
	static FString ConvertRelativePathToFull(const FString& BasePath, const FString& Path)
	{
		return **Path == TCHAR('/') ? Path : BasePath / Path;
	}
};
