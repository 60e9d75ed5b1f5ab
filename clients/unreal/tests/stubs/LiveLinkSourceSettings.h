#pragma once
#include "CoreMinimal.h"

class ULiveLinkSourceSettings : public UObject
{
	GENERATED_BODY()
};
