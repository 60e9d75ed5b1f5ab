#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>

#include "CoreMinimal.h"

enum EFileRead { FILEREAD_None, FILEREAD_Silent };

struct FFileHelper
{
	static bool LoadFileToArray(TArray<uint8>& Result, const TCHAR* Filename, uint32)
	{
		if (!std::filesystem::is_regular_file(Filename))
		{
			return false;
		}
		std::ifstream File(std::filesystem::path(Filename), std::ios::binary);
		for (auto At = std::istreambuf_iterator<char>(File); At != std::istreambuf_iterator<char>(); ++At)
		{
			Result.Add(static_cast<uint8>(*At));
		}
		return !File.bad();
	}
};
