#pragma once
#include "CoreMinimal.h"

class ILiveLinkSource;
struct FLiveLinkSourcePreset
{
};

class ULiveLinkSourceFactory : public UObject
{
	GENERATED_BODY()

	virtual FText GetSourceDisplayName() const = 0;
	virtual FText GetSourceTooltip() const = 0;
	enum class EMenuType
	{
		SubPanel,
		MenuEntry,
		Disabled,
	};
	virtual EMenuType GetMenuType() const { return EMenuType::Disabled; }
	virtual TSharedPtr<ILiveLinkSource> CreateSource(const FString& ConnectionString) const = 0;
	virtual TSharedPtr<ILiveLinkSource> CreateSource(const FLiveLinkSourcePreset&) { return {}; } // not in 5.3
};
